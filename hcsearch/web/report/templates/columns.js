// The numbers that cards show, and the choice of them.
const Columns = (() => {
  const { element } = Parts;
  const ELSEWHERE = new Set(["id", "circuit", "array", "status"]);
  const USUAL = ["symmetry", "n_foldings", "dof", "needed_margin", "least_gap", "min_clearance", "deploy_time", "score"];
  let chosen = new Set(USUAL);

  const shown = (name) => chosen.has(name);

  // names : of columns as the address has them; the usual ones where empty.
  function choose(names) {
    chosen = new Set(names.length ? names : USUAL);
  }

  // As the address has them; empty for the usual ones.
  function names() {
    const usual = chosen.size === USUAL.length && USUAL.every(shown);
    return usual ? "" : [...chosen].join(",");
  }

  // Check boxes for the columns that hold anything.
  function fill(table, place) {
    const known = table.quantities.filter(({ name }) => !ELSEWHERE.has(name) && table.designs[name].some((value) => value !== null));
    place.replaceChildren(...known.map(({ name, label, note }) => element("label", { title: note },
      element("input", { type: "checkbox", name: "column", value: name }), ` ${label}`)));
    check(place);
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

  return { shown, choose, names, fill, check, take };
})();
