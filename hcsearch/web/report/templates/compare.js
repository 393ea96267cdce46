// Two to four designs side by side: pictures, motions that play together, and numbers with the better ones marked.
const Compare = (() => {
  const { element } = Parts;
  const LEAST = 2, MOST = 4, SECONDS = 8, STEPS = 1000;
  let picked = [];

  const has = (i) => picked.includes(i);
  const can = (count) => count >= LEAST && count <= MOST;

  function pick(i, on) {
    picked = picked.filter((k) => k !== i);
    if (on && picked.length < MOST) picked.push(i);
  }

  const own = (table, i, name) => {
    const row = table.row(i, Card.drawn(table, i));
    return (row !== undefined && name in table.foldings ? table.foldings[name][row] : table.designs[name][i]) ?? null;
  };

  // Which of some values are the best by the direction of their quantity; none where all that are known are equal.
  function best(quantity, values) {
    const known = values.filter((value) => value !== null);
    if (!quantity.better || new Set(known).size < 2) return values.map(() => false);
    const limit = quantity.better === "higher" ? Math.max(...known) : Math.min(...known);
    return values.map((value) => value === limit);
  }

  function numbers(table, designs) {
    const lines = table.quantities.filter(({ name }) => !table.card_heads.includes(name)).map((quantity) => {
      const values = designs.map((i) => own(table, i, quantity.name));
      if (values.every((value) => value === null)) return null;
      const better = best(quantity, values);
      return element("tr", {}, element("th", { scope: "row", title: quantity.note }, quantity.label),
        ...values.map((value, k) => element("td", better[k] ? { class: "better" } : {},
          value === null ? "–" : Parts.worded(quantity, value), better[k] ? element("small", {}, " better") : null)));
    });
    const head = element("tr", {}, element("th", { scope: "col" }, "design"),
      ...designs.map((i) => element("th", { scope: "col" }, `#${table.designs.id[i]}`)));
    return element("div", { class: "wide" }, element("table", { class: "compared" }, element("thead", {}, head), element("tbody", {}, ...lines.filter(Boolean))));
  }

  // One slider and one button for all motions, each from its packed to its flat state. mounted : of `Motions.mount`.
  function together(mounted) {
    const range = element("input", { type: "range", min: 0, max: STEPS, value: 0, "aria-label": "Place in all motions, from packed to flat" });
    const go = element("button", { type: "button", class: "chip" }, "play all");
    let share = 0, last = null, going = false;

    function set(to) {
      share = Math.min(1, Math.max(0, to));
      range.value = Math.round(STEPS * share);
      for (const { player, payload: { at } } of mounted) player.seek(at[0] + share * (at.at(-1) - at[0]));
    }

    function run(on) {
      going = on;
      last = null;
      go.textContent = on ? "pause all" : "play all";
      if (!on) return;
      mounted.forEach(({ player }) => player.pause());
      if (share >= 1) set(0);
      requestAnimationFrame(frame);
    }

    function frame(now) {
      if (!going || !go.isConnected) return;
      set(share + Math.min(0.1, (now - (last ?? now)) / 1000) / SECONDS);
      last = now;
      if (share >= 1) run(false);
      else requestAnimationFrame(frame);
    }

    go.addEventListener("click", () => run(!going));
    range.addEventListener("input", () => { run(false); set(range.value / STEPS); });
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) run(true);
    return element("p", { class: "together" }, go, range);
  }

  // places : where the motion of each design goes.
  function content(table, designs, places) {
    return element("div", { class: "card" },
      element("header", {}, element("h3", {}, `${designs.length} designs`), element("button", { type: "button", class: "copy close" }, "close")),
      element("div", { class: "together-place" }),
      element("ul", { class: "columns" }, ...designs.map((i, k) => element("li", {},
        element("p", { class: "named" }, element("strong", {}, `#${table.designs.id[i]}`), Parts.badge(table.status[i])),
        element("div", { class: "thumb" }, Parts.picture(table, i, Card.drawn(table, i), true)), places[k]))),
      numbers(table, designs));
  }

  // The check boxes on cards and the button that compares; the picked designs stand in the address.
  // refresh : draws a card anew.
  function listen(table, gallery, button, dialog, refresh) {
    const index = new Map(table.designs.id.map((id, i) => [String(id), i]));

    function offer() {
      button.hidden = !picked.length;
      button.disabled = !can(picked.length);
      button.textContent = can(picked.length) ? `compare ${picked.length} designs` : "compare: pick one more";
    }

    // What the address says.
    function follow() {
      const before = picked;
      picked = Address.list(Address.read().compare).map((id) => index.get(id)).filter((i) => i !== undefined).slice(0, MOST);
      for (const i of new Set([...before, ...picked])) if (before.includes(i) !== has(i)) refresh(i);
      offer();
    }

    gallery.addEventListener("change", ({ target }) => {
      if (target.name !== "pick") return;
      pick(Number(target.value), target.checked);
      target.checked = has(Number(target.value));
      offer();
      Address.replace({ compare: picked.map((i) => table.designs.id[i]).join(",") });
    });
    button.addEventListener("click", () => dialog.open(picked));
    addEventListener("popstate", follow);
    follow();
  }

  return { has, can, best, content, together, listen };
})();
