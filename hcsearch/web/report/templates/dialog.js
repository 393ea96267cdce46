// One design enlarged: numbers on its picture, all its foldings, what was tried of each, and its motion.
const Dialog = (() => {
  const { element } = Parts;
  const COLUMNS = ["dof", "flat_pairs", "needed_margin", "least_gap", "min_clearance", "deploy_time"];
  let player = null;

  function stop() {
    player?.dispose();
    player = null;
  }

  // Names a scene where it is not the usual one; where : names the database that may hold it.
  const option = (scene, where) => (scene === null || scene === "default" ? "" : ` --scene '${scene}'${where}`);

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

  async function read(address) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(answer.statusText);
    return answer.json();
  }

  async function play(table, row, place) {
    const motion = row === undefined ? null : table.player(row);
    place.hidden = !motion || typeof hcsearchPlayer === "undefined";
    if (place.hidden) return;
    let payload = motion;
    if (typeof motion === "string") {
      place.textContent = "The motion is being read.";
      try {
        payload = await read(motion);
      } catch {
        place.textContent = "The motion cannot be read right now: close the picture and open it again.";
        return;
      }
      if (!place.isConnected || !place.closest("dialog").open) return; // another design is shown by now, or none
    }
    place.replaceChildren();
    player = hcsearchPlayer.mount(place, payload, { numbers: true });
  }

  function show(table, i, dialog) {
    stop();
    const rows = table.rows(i), crease = Card.drawn(table, i), row = table.row(i, crease), place = element("div", { class: "player" });
    const link = table.page(i) ? element("a", { href: table.page(i) }, "its own page") : null;
    const reason = row === undefined ? null : table.foldings.why[row];
    dialog.replaceChildren(element("div", { class: "card", "data-index": i },
      element("header", {}, element("h3", {}, `#${table.designs.id[i]}`), Parts.badge(table.status[i]), link,
        element("button", { type: "button", class: "copy close" }, "close")),
      element("div", { class: "thumb" }, Parts.picture(table, i, crease, true)),
      rows.length ? element("div", { class: "chips", role: "group", "aria-label": "Foldings" },
        ...rows.map((k) => Parts.chip(table, k, k === row))) : null,
      reason ? element("p", { class: "why" }, reason) : null,
      place,
      Parts.code("circuit notation", table.designs.circuit[i]),
      Parts.code("array notation", table.designs.array[i]),
      Parts.facts(table, i, row, (name) => name !== "id"),
      rows.length ? foldings(table, rows) : null,
      row !== undefined && table.foldings.scene[row] !== null ? Parts.code("command", command(table, i, row)) : null,
      Parts.code("command", `hcsearch show ${table.designs.id[i]} --html${option(table.scene, "")}${table.where}`)));
    if (!dialog.open) dialog.showModal();
    play(table, row, place);
  }

  // Clicks in a gallery and here: enlarge a design, choose a folding, copy a text, close. refresh : draws a card anew.
  function listen(table, gallery, dialog, refresh) {
    function choose(button) {
      const row = Number(button.dataset.row), i = table.foldings.design[row];
      Card.choose(table, row);
      refresh(i);
      if (dialog.open) show(table, i, dialog);
      (dialog.open ? dialog : gallery).querySelector(`[data-row="${row}"]`)?.focus({ preventScroll: true });
    }

    document.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      const enlarged = event.target.closest("#gallery .thumb, #gallery .more");
      if (event.target === dialog || button?.classList.contains("close")) dialog.close();
      else if (enlarged) show(table, Number(enlarged.closest(".card").dataset.index), dialog);
      else if (!button) return;
      else if (button.dataset.row) choose(button);
      else if (button.classList.contains("copy")) copy(button);
    });
    dialog.addEventListener("close", stop);
  }

  return { listen };
})();
