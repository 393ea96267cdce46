// Facets: the values of a few columns with the number of designs that have each; those that are chosen filter.
const Facets = (() => {
  const { element } = Parts;
  const NAMES = ["status", "grid", "n", "array"], MOST = 20; // values of a facet

  const column = (table, name) => (name === "status" ? table.status : table.designs[name]);

  // The columns in which the designs differ, but not in too many values, and those with chosen values.
  function varied(table, chosen) {
    return NAMES.filter((name) => {
      const { size } = new Set(column(table, name) || []);
      return (size > 1 && size <= MOST) || chosen[name]?.length;
    });
  }

  // Whether a design has a chosen value in each column but one.
  function fits(table, chosen, i, but = null) {
    return Object.entries(chosen).every(([name, values]) =>
      name === but || !values.length || values.includes(String(column(table, name)[i])));
  }

  // The statuses best first, numbers rising, others by their counts; of too many values those that are chosen.
  function ordered(table, name, counts, values) {
    const best = (word) => { const at = table.statuses.indexOf(word); return at < 0 ? table.statuses.length : at; };
    const order = { status: ([a], [b]) => best(a) - best(b), n: ([a], [b]) => a - b }[name] || (([, a], [, b]) => b - a);
    return [...counts].sort(order).filter(([value]) => counts.size <= MOST || values.includes(value));
  }

  // designs : those that fit all but the facets. chosen : chosen values by column.
  function show(table, place, designs, chosen) {
    const focused = document.activeElement?.dataset?.facet;
    place.replaceChildren(...varied(table, chosen).map((name) => {
      const values = chosen[name] || [], counts = new Map(values.map((value) => [value, 0]));
      for (const i of designs) {
        if (!fits(table, chosen, i, name)) continue;
        const value = String(column(table, name)[i]);
        counts.set(value, (counts.get(value) || 0) + 1);
      }
      const shown = ordered(table, name, counts, values), label = table.quantity(name).label;
      return element("div", { class: "facet", role: "group", "aria-label": label }, element("span", {}, label),
        ...shown.map(([value, count]) => element("button", { type: "button", class: `chip${name === "status" ? ` fold s-${value}` : ""}`,
          "data-facet": `${name}=${value}`, "aria-pressed": String(values.includes(value)) },
        `${Parts.spaced(value)} `, element("small", {}, count.toLocaleString("en")))));
    }));
    if (focused) place.querySelector(`[data-facet="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  }

  // The chosen values after a click on a button.
  function toggled(chosen, button) {
    const [name, value] = button.dataset.facet.split("=");
    const values = chosen[name] || [];
    return { ...chosen, [name]: values.includes(value) ? values.filter((one) => one !== value) : [...values, value] };
  }

  return { NAMES, fits, show, toggled };
})();
