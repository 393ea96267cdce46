// The large view of one design: picture beside motion, then numbers, all its foldings, and what was tried of each.
const Large = (() => {
  const { element } = Parts;
  const COLUMNS = ["dof", "flat_pairs", "needed_margin", "least_gap", "min_clearance", "deploy_time"];

  const quoted = (text) => `'${text.replaceAll("'", `'"'"'`)}'`; // as shells read it

  // Names a scene where it is not the usual one; where : names the database that may hold it.
  const option = (scene, where) => (scene === null || scene === "default" ? "" : ` --scene ${quoted(scene)}${where}`);

  function command(table, i, row) {
    const { scene, crease } = table.foldings;
    return `hcsearch deploy ${table.designs.circuit[i]}:${crease[row]}${option(scene[row], table.where)}`;
  }

  const named = ({ label, unit }) => label + (unit && `, ${unit}`);
  const value = (quantity, known) => (known === null ? element("td", { class: "none" }, "–")
    : element("td", { "data-name": named(quantity) }, Parts.written(known)));

  function foldings(table, rows) {
    const shown = COLUMNS.map((name) => table.folding_quantities.find((q) => q.name === name))
      .filter((q) => q && rows.some((row) => table.foldings[q.name][row] !== null));
    const head = element("tr", {}, ...["creases", "status", ...shown.map(named), "scene, and why"]
      .map((text) => element("th", { scope: "col" }, text)));
    const lines = rows.map((row) => element("tr", {},
      element("th", { scope: "row" }, Parts.creases(table, row).join("|")),
      element("td", {}, Parts.badge(Parts.foldingStatus(table, row))),
      ...shown.map((q) => value(q, table.foldings[q.name][row])),
      element("td", { class: "reason" }, table.foldings.why[row] || "–")));
    return element("div", { class: "wide" }, element("table", { class: "foldings" }, element("thead", {}, head), element("tbody", {}, ...lines)));
  }

  // The content of the view; place : where the motion of the drawn folding goes.
  function content(table, i, place) {
    const rows = table.rows(i), crease = Card.drawn(table, i), row = table.row(i, crease);
    const link = table.page(i) ? element("a", { href: table.page(i) }, "its own page") : null;
    const reason = row === undefined ? null : table.foldings.why[row];
    return element("div", { class: "card", "data-index": i },
      element("header", {}, element("h3", {}, `#${table.designs.id[i]}`), Parts.badge(table.status[i]), link,
        element("button", { type: "button", class: "copy step", "data-step": -1 }, "previous"),
        element("button", { type: "button", class: "copy step", "data-step": 1 }, "next"),
        element("button", { type: "button", class: "copy close" }, "close")),
      element("div", { class: "beside" },
        element("div", { class: "thumb" }, Parts.picture(table, i, crease, true)), place),
      rows.length ? element("div", { class: "chips", role: "group", "aria-label": "Foldings" },
        ...rows.map((k) => Parts.chip(table, k, k === row))) : null,
      reason ? element("p", { class: "why" }, reason) : null,
      Parts.facts(table, i, row, (name) => !table.card_heads.includes(name)),
      rows.length ? foldings(table, rows) : null,
      Parts.code("circuit notation", table.designs.circuit[i]),
      Parts.code("array notation", table.designs.array[i]),
      table.readable[i] && row !== undefined && table.foldings.scene[row] !== null ? Parts.code("command", command(table, i, row)) : null,
      Parts.code("command", `hcsearch show ${table.designs.id[i]} --html${option(table.scene, "")}${table.where}`));
  }

  return { content };
})();
