// The numbers that cards and tables show, and the choice of them.
const Columns = (() => {
  const { element } = Parts;
  let chosen = new Set();

  const shown = (name) => chosen.has(name);

  // names : of columns as the address has them; the usual ones where empty.
  function choose(table, names) {
    chosen = new Set(names.length ? names : table.card_columns);
  }

  // As the address has them; empty for the usual ones.
  function names(table) {
    const usual = chosen.size === table.card_columns.length && table.card_columns.every(shown);
    return usual ? "" : [...chosen].join(",");
  }

  // The columns that can be chosen: those that hold anything.
  const offered = (table) => table.quantities.filter(({ name }) => !table.card_heads.includes(name) && table.designs[name].some((value) => value !== null));

  // A check box for each.
  function fill(table, place) {
    place.replaceChildren(...offered(table).map(({ name, label, note }) => element("label", { title: note },
      element("input", { type: "checkbox", name: "column", value: name }), ` ${label}`)));
  }

  function check(place) {
    for (const box of place.querySelectorAll("input")) box.checked = shown(box.value);
  }

  // From the boxes; those of other columns stay as they are.
  function take(place) {
    for (const box of place.querySelectorAll("input")) {
      if (box.checked) chosen.add(box.value);
      else chosen.delete(box.value);
    }
  }

  return { shown, choose, names, offered, fill, check, take };
})();
