// Pieces of cards and dialogs.
const Parts = (() => {
  const SVG = document.querySelector("svg").namespaceURI; // of the legend: the page names no address

  function element(name, attributes = {}, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) if (value !== null) made.setAttribute(key, value);
    made.append(...children.filter((child) => child !== null));
    return made;
  }

  function shape(name, attributes, text) {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  const MOST_PIXELS = 1.3; // of an enlarged picture to a unit, so that lines and numbers of large panels stay fine

  // numbers : also of the creases, and a dot on panel 0, as `draw_circuit` with numbers.
  function picture(table, i, crease, numbers = false) {
    if (!table.readable[i]) return element("p", { class: "nothing" }, "no picture");
    const drawn = Geometry.picture(table.grids, table.designs.circuit[i], crease, table.size);
    const svg = shape("svg", { role: "img", ...(drawn.sides === 3 && { class: "triangles" }), viewBox: `0 0 ${drawn.width} ${drawn.height}` });
    svg.append(shape("title", {}, table.designs.circuit[i]));
    svg.append(...drawn.paths.map(([kind, d]) => shape("path", { class: kind, d })));
    if (numbers) {
      svg.style.maxWidth = `${MOST_PIXELS * drawn.width}px`;
      svg.style.maxHeight = `${MOST_PIXELS * drawn.height}px`;
      svg.append(shape("circle", { class: "start", cx: drawn.start[0], cy: drawn.start[1], r: 9 }));
      const group = shape("g", { class: "numbers" });
      group.append(...drawn.creases.map(([a, b], k) => shape("text", {
        x: Geometry.rounded(0.72 * a[0] + 0.28 * b[0]), y: Geometry.rounded(0.72 * a[1] + 0.28 * b[1]) + 7 }, k)));
      svg.append(group);
    }
    return svg;
  }

  function code(name, text) {
    return element("p", { class: "code" }, element("code", {}, text),
      element("button", { type: "button", class: "copy", "aria-label": `Copy the ${name}` }, "copy"));
  }

  const TINY = 1e-9; // what rounding leaves of a zero, in any unit shown here
  function written(value) {
    if (typeof value !== "number" || Number.isInteger(value)) return String(value);
    return Math.abs(value) < TINY ? "0" : String(Number(value.toPrecision(4)));
  }

  // A value of a quantity with its unit, or a word.
  function worded({ kind, unit }, value) {
    if (kind === "boolean") return value ? "yes" : "no";
    return kind === "text" ? spaced(value) : written(value) + (unit && ` ${unit}`);
  }

  const spaced = (word) => word.replaceAll("_", " ");
  const badge = (status) => element("span", { class: `badge s-${status}` }, spaced(status));

  // The status of a folding; before any verdict, that of its twist.
  function foldingStatus(table, row) {
    const { status, twist } = table.foldings;
    return status[row] ?? (twist[row] === null ? "not_judged" : twist[row] ? "twisted" : "untwisted");
  }

  // The two flat creases of a folding, which are half a circuit apart.
  function creases(table, row) {
    const { crease, design } = table.foldings, half = table.designs.n[design[row]] / 2;
    return [crease[row], crease[row] + half];
  }

  function chip(table, row, shown) {
    const { twist, why } = table.foldings, status = foldingStatus(table, row), [crease, opposite] = creases(table, row);
    const text = twist[row] ? `twist ${twist[row]}` : spaced(status);
    return element("button", { type: "button", class: `chip fold s-${status}`, "data-row": row, "aria-pressed": String(shown),
      title: [`flat creases ${crease} and ${opposite}, ${spaced(status)}`, why[row]].filter(Boolean).join(": ") },
    `${crease}|${opposite} `, element("small", {}, text));
  }

  // Facts of a design, those of a folding where it has its own.
  function facts(table, i, row, names) {
    const made = table.quantities.filter(({ name }) => names(name)).map((quantity) => {
      const own = row !== undefined && quantity.name in table.foldings;
      const value = (own ? table.foldings[quantity.name][row] : table.designs[quantity.name][i]) ?? null;
      return value === null ? null : element("div", {}, element("dt", { title: quantity.note }, quantity.label),
        element("dd", {}, worded(quantity, value)));
    });
    return element("dl", { class: "facts" }, ...made);
  }

  return { element, shape, picture, code, written, worded, spaced, badge, foldingStatus, creases, chip, facts };
})();
