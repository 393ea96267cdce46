// Motions of foldings: read where they are at an address, and mounted in the player.
const Motions = (() => {
  async function read(address) {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(answer.statusText);
    return answer.json();
  }

  const known = (table, row) => (row === undefined || typeof hcsearchPlayer === "undefined" ? null : table.player(row));

  // What moves the panels, and for how long.
  const named = ({ axis, at }) => (axis === "time"
    ? `Opened by springs, ${Number((at.at(-1) - at[0]).toPrecision(2))} s` : "Driven along the planned path");

  // The player of a folding's motion and the motion, once it plays in a place; null where there is none, or where
  // `wanted` says by then that something else is shown.
  async function mount(table, row, place, options, wanted) {
    const motion = known(table, row);
    place.hidden = !motion;
    if (!motion) return null;
    let payload = motion;
    if (typeof motion === "string") {
      place.dataset.note = "The motion is being read.";
      try {
        payload = await read(motion);
      } catch {
        place.dataset.note = "The motion cannot be read right now: try again later.";
        return null;
      }
      if (!wanted()) return null;
    }
    delete place.dataset.note;
    place.replaceChildren();
    const player = hcsearchPlayer.mount(place, payload, options);
    place.prepend(Parts.element("p", { class: "moves" }, named(payload)));
    return { player, payload };
  }

  return { known, mount };
})();
