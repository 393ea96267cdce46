// The designs as a table; more rows are made as its end comes near to what is seen.
const Rows = (() => {
  const { element } = Parts;
  const STEP = 100, MOST_PRINTED = 400, LONG = 24;
  const FIRST = ["id", "status"], LAST = ["circuit", "array"];

  // The columns: the id and the status, the chosen numbers, the notations.
  function columns(table) {
    return [...FIRST.map(table.quantity), ...Columns.offered(table).filter(({ name }) => Columns.shown(name)), ...LAST.map(table.quantity)];
  }

  function cell(table, i, quantity) {
    if (quantity.name === "id") {
      return element("th", { scope: "row" }, element("button", { type: "button", "data-design": i }, `#${table.designs.id[i]}`));
    }
    if (quantity.name === "status") return element("td", {}, Parts.badge(table.status[i]));
    const value = table.designs[quantity.name][i], { kind, label, unit } = quantity;
    const look = kind !== "text" ? "number" : value?.length > LONG ? "long" : null;
    return element("td", { class: look, "data-name": label + (unit && `, ${unit}`) },
      value === null ? "–" : Parts.worded({ ...quantity, unit: "" }, value));
  }

  function row(table, i, shown) {
    return element("tr", { "data-index": i }, element("td", { class: "choice" }, Card.pick(table, i)), ...shown.map((quantity) => cell(table, i, quantity)));
  }

  // A head sorts, if designs differ in its numbers.
  function head({ name, label, unit, note, kind }, sorts) {
    const text = [label, ...(unit ? [" ", element("small", {}, unit)] : [])];
    return element("th", { scope: "col", title: note, class: kind === "text" ? null : "number", "data-name": name },
      ...(sorts ? [element("button", { type: "button", "data-sort": name }, ...text)] : text));
  }

  // place : for the table. sortBy : sorts by an order as the address has it. opened : shows a design.
  function open(table, place, sortBy, opened) {
    const sortable = new Set(Table.sortable(table).map(({ name }) => name));
    const heads = element("tr"), body = element("tbody"), end = element("div");
    let order = [], sort = "", shown = [];
    place.append(element("table", { class: "rows" }, element("thead", {}, heads), body), end);

    function extend(count) {
      const made = body.childElementCount;
      body.append(...order.slice(made, made + count).map((i) => row(table, i, shown)));
    }

    function mark() {
      for (const one of heads.children) {
        if (one.dataset.name !== sort.replace("-", "")) one.removeAttribute("aria-sort");
        else one.setAttribute("aria-sort", sort.startsWith("-") ? "descending" : "ascending");
      }
    }

    const watch = new IntersectionObserver((entries) => {
      if (entries.some(({ isIntersecting }) => isIntersecting)) more();
    }, { rootMargin: "600px" });

    function fill() {
      body.replaceChildren();
      mark();
      more();
    }

    // The end is watched anew: it may still be near, of which the observer would not speak again.
    function more() {
      extend(STEP);
      watch.unobserve(end);
      if (body.childElementCount < order.length) watch.observe(end);
    }

    // The same rows stay, with what has the focus in them.
    function show(chosen, by) {
      if (by === sort && chosen.length === order.length && chosen.every((i, k) => i === order[k])) return;
      [order, sort] = [chosen, by];
      fill();
    }

    function layout() {
      shown = columns(table);
      heads.replaceChildren(element("th", { scope: "col", class: "choice" }, "compare"), ...shown.map((quantity) => head(quantity, sortable.has(quantity.name))));
      fill();
    }

    // A row shows nothing of the chosen folding, and what has the focus in it stays.
    function refresh(i) {
      const pick = body.querySelector(`[data-index="${i}"] [name=pick]`);
      if (pick) pick.checked = Compare.has(i);
    }

    function print(on) {
      const count = Math.min(order.length, MOST_PRINTED);
      if (on) extend(Math.max(0, count - body.childElementCount));
      return Math.max(count, body.childElementCount);
    }

    heads.addEventListener("click", ({ target }) => {
      const button = target.closest("[data-sort]");
      if (!button) return;
      const better = Table.betterFirst(table.quantity(button.dataset.sort));
      if (sort !== better) sortBy(better);
      else sortBy(sort.startsWith("-") ? sort.slice(1) : `-${sort}`);
    });
    body.addEventListener("click", ({ target }) => {
      if (target.closest("button, label") || !getSelection().isCollapsed) return;
      opened(Number(target.closest("tr").dataset.index));
    });
    return { show, layout, refresh, print };
  }

  return { open };
})();
