// The dialog: one design enlarged, or several side by side; its designs stand in the address, and whether the panels of
// one are drawn apart.
const Dialog = (() => {
  const { element } = Parts;
  let players = [], shown = [];

  function stop() {
    for (const { player } of players) player.dispose();
    players = [];
  }

  async function play(table, designs, places, dialog) {
    const rows = designs.map((i) => table.row(i, Card.drawn(table, i))), several = designs.length > 1;
    const wanted = () => dialog.open && places[0].isConnected;
    const apart = several ? {} : { exploded: Address.read().exploded === "yes", parted: (on) => Address.replace({ exploded: on ? "yes" : "" }) };
    const tried = await Promise.all(rows.map((row, k) => Motions.mount(table, row, places[k], { numbers: true, ...apart }, wanted)));
    const mounted = tried.filter(Boolean);
    if (!wanted()) { // while motions were read, the view was closed or went on
      for (const { player } of mounted) player.dispose();
      return;
    }
    players = mounted;
    if (several && mounted.length) dialog.querySelector(".together-place").append(Compare.together(mounted));
  }

  function show(table, designs, dialog) {
    stop();
    shown = designs;
    const places = designs.map(() => element("div", { class: "player" }));
    dialog.setAttribute("aria-label", designs.length > 1 ? "Comparison" : "Large picture");
    dialog.replaceChildren(designs.length > 1 ? Compare.content(table, designs, places) : Large.content(table, designs[0], places[0]));
    if (!dialog.open) dialog.showModal();
    play(table, designs, places, dialog);
  }

  // Clicks in a gallery and here: enlarge designs, go on to others, choose a folding, copy a text, close.
  // refresh : draws a card anew. order : the designs through which the arrow keys step.
  function listen(table, gallery, dialog, { refresh, order }) {
    const index = new Map(table.designs.id.map((id, i) => [String(id), i]));
    const ids = (designs) => designs.map((i) => table.designs.id[i]).join(",");
    let among = null;

    function open(designs, place = null) {
      among = place;
      Address.enter({ id: ids(designs) });
      show(table, designs, dialog);
    }

    function choose(button) {
      const row = Number(button.dataset.row), i = table.foldings.design[row];
      Card.choose(table, row);
      refresh(i);
      if (dialog.open) show(table, [i], dialog);
      (dialog.open ? dialog : gallery).querySelector(`[data-row="${row}"]`)?.focus({ preventScroll: true });
    }

    function step(by) {
      const all = among || order(), to = all[all.indexOf(shown[0]) + by];
      if (shown.length > 1 || to === undefined) return;
      show(table, [to], dialog);
      Address.replace({ id: ids([to]) });
      dialog.querySelector(`[data-step="${by}"]`).focus({ preventScroll: true });
    }

    // What the address says.
    function follow() {
      const designs = Address.list(Address.read().id).map((id) => index.get(id)).filter((i) => i !== undefined);
      if (designs.length === 1 || Compare.can(designs.length)) {
        if (!dialog.open || ids(designs) !== ids(shown)) show(table, designs, dialog);
      } else if (dialog.open) dialog.close();
    }

    document.addEventListener("click", (event) => {
      const button = event.target.closest("button");
      const enlarged = event.target.closest("#gallery .thumb, #gallery .more");
      if (event.target === dialog || button?.classList.contains("close")) dialog.close();
      else if (enlarged) open([Number(enlarged.closest(".card").dataset.index)]);
      else if (!button) return;
      else if (button.dataset.design) open([Number(button.dataset.design)]);
      else if (button.dataset.step) step(Number(button.dataset.step));
      else if (button.dataset.row) choose(button);
      else if (button.classList.contains("copy")) copy(button);
    });
    dialog.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      // the player and its slider have arrow keys of their own
      if (!by || event.target.closest(".player, input, select")) return;
      event.preventDefault();
      step(by);
    });
    dialog.addEventListener("close", () => {
      stop();
      if (Address.read().id) Address.leave({ id: "", exploded: "" });
    });
    addEventListener("popstate", follow);
    return { open, follow };
  }

  return { listen };
})();
