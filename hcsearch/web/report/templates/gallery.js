// The gallery: rows of cards of one height, made as they come near to what is seen, and thrown away behind it.
const Gallery = (() => {
  const AHEAD = 2; // rows made before they are seen
  const MOST_PRINTED = 400;

  function open(table, list) {
    let order = [], height = 0, columns = 1, printing = false;
    const made = new Map();

    // One height for all: that of the tallest among the designs with the most to say.
    function measure() {
      columns = getComputedStyle(list).gridTemplateColumns.split(" ").length;
      const longest = (length) => order.reduce((a, b) => (length(b) > length(a) ? b : a), order[0]);
      const { circuit, array } = table.designs;
      const why = (i) => { const row = table.row(i, Card.drawn(table, i)); return row === undefined ? 0 : (table.foldings.why[row] || "").length; };
      const known = (i) => why(i) + 1000 * (table.designs.min_clearance?.[i] != null) + 100 * (table.designs.needed_margin?.[i] != null);
      const sample = order.length ? [order[0], longest((i) => circuit[i].length), longest((i) => String(array[i]).length),
        longest((i) => table.rows(i).length), longest(why), longest(known)] : [];
      list.classList.add("measured");
      list.replaceChildren(...[...new Set(sample)].map((i) => Card.make(table, i)));
      height = Math.max(0, ...[...list.children].map((card) => card.offsetHeight));
      list.classList.remove("measured");
      list.replaceChildren();
      made.clear();
      list.style.setProperty("--row", `${height}px`);
    }

    function place(first, last) {
      const wanted = order.slice(first, last), keep = new Set(wanted);
      for (const [i, card] of made) {
        if (!keep.has(i)) {
          card.remove();
          made.delete(i);
        }
      }
      let before = list.firstElementChild;
      wanted.forEach((i, k) => {
        let card = made.get(i);
        if (!card) made.set(i, card = Card.make(table, i));
        card.setAttribute("aria-setsize", order.length);
        card.setAttribute("aria-posinset", first + k + 1);
        if (card === before) before = before.nextElementSibling;
        else list.insertBefore(card, before);
      });
    }

    function update() {
      if (printing || list.hidden) return;
      const gap = parseFloat(getComputedStyle(list).rowGap) || 0, step = height + gap;
      const rows = Math.ceil(order.length / columns), box = list.getBoundingClientRect();
      const from = Math.max(0, Math.min(rows - 1, Math.floor(-box.top / step) - AHEAD));
      const to = Math.max(from, Math.min(rows, Math.ceil((innerHeight - box.top) / step) + AHEAD));
      list.style.paddingTop = `${from * step}px`;
      list.style.paddingBottom = `${(rows - to) * step}px`;
      place(from * columns, to * columns);
    }

    function show(chosen) {
      order = chosen;
      update();
    }

    function refresh(i) {
      const card = made.get(i);
      if (card) Card.fill(table, i, card);
    }

    // Again where the cards themselves brought a scroll bar that takes from the width.
    function layout() {
      for (let width = 0, tries = 0; !printing && !list.hidden && tries < 2 && list.clientWidth !== width; tries++) {
        width = list.clientWidth;
        measure();
        update();
      }
    }

    function print(on) {
      printing = on;
      list.style.paddingTop = list.style.paddingBottom = "0";
      if (on) place(0, Math.min(order.length, MOST_PRINTED));
      else update();
      return Math.min(order.length, MOST_PRINTED);
    }

    let wide = innerWidth;
    function resized() {
      if (innerWidth === wide) return update();
      wide = innerWidth;
      return layout();
    }

    addEventListener("scroll", update, { passive: true });
    addEventListener("resize", resized);
    return { show, layout, refresh, print };
  }

  return { open };
})();
