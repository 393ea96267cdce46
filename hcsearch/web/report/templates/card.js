// One design of the gallery: its picture, its foldings to choose from, its numbers.
const Card = (() => {
  const { element } = Parts;
  const MOST_CHIPS = 6;
  // Which folding a reader chose to see, by design.
  const chosen = new Map();

  const drawn = (table, i) => (chosen.has(i) ? chosen.get(i) : table.best[i]);

  // The foldings that fit on a card, the drawn one among them.
  function listed(table, i) {
    const rows = table.rows(i), shown = table.row(i, drawn(table, i));
    if (rows.length <= MOST_CHIPS) return rows;
    return rows.indexOf(shown) < MOST_CHIPS ? rows.slice(0, MOST_CHIPS) : [...rows.slice(0, MOST_CHIPS - 1), shown];
  }

  function chips(table, i, rows) {
    if (!rows.length) return null;
    const more = table.rows(i).length - rows.length;
    return element("div", { class: "chips", role: "group", "aria-label": `Foldings of design ${table.designs.id[i]}` },
      ...rows.map((row) => Parts.chip(table, row, table.foldings.crease[row] === drawn(table, i))),
      more ? element("button", { type: "button", class: "chip more" }, `${more} more`) : null);
  }

  function named(table, i) {
    const id = table.designs.id[i];
    return table.page(i) ? element("a", { href: table.page(i) }, `#${id}`) : `#${id}`;
  }

  // Whether a design is among those to compare.
  function pick(table, i) {
    const box = element("input", { type: "checkbox", name: "pick", value: i, "aria-label": `Compare design ${table.designs.id[i]}` });
    box.checked = Compare.has(i);
    return element("label", { class: "pick", title: "compare" }, box);
  }

  // The parts that depend on the folding that is drawn.
  function fill(table, i, card) {
    const row = table.row(i, drawn(table, i));
    const reason = row === undefined ? null : table.foldings.why[row];
    card.replaceChildren(
      element("header", {}, element("h3", {}, named(table, i)), Parts.badge(table.status[i]), pick(table, i)),
      element("button", { type: "button", class: "thumb", "aria-label": `Enlarge design ${table.designs.id[i]}` },
        Parts.picture(table, i, drawn(table, i))),
      Parts.code("circuit notation", table.designs.circuit[i]),
      Parts.code("array notation", table.designs.array[i]),
      ...[chips(table, i, listed(table, i))].filter(Boolean),
      ...(reason ? [element("p", { class: "why", title: reason }, reason)] : []),
      Parts.facts(table, i, row, Columns.shown),
    );
    return card;
  }

  function make(table, i) {
    return fill(table, i, element("li", { class: "card", "data-index": i }));
  }

  function choose(table, row) {
    chosen.set(table.foldings.design[row], table.foldings.crease[row]);
  }

  return { make, fill, choose, drawn, pick };
})();
