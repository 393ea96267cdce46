"use strict";
(() => {
  const gallery = document.getElementById("gallery");
  const cards = [...gallery.children];
  const tools = document.getElementById("tools");
  const find = document.getElementById("find");
  const state = document.getElementById("state");
  const large = document.getElementById("large");
  const total = Number(gallery.dataset.total);

  // Filter: every word typed must occur in the notations, the status or the number of a design.
  const texts = cards.map((card) =>
    [...card.querySelectorAll("h3, .badge, code")].map((part) => part.textContent).join(" ").toLowerCase());

  function filter() {
    const words = find.value.toLowerCase().split(/\s+/).filter(Boolean);
    const only = [...tools.querySelectorAll("input[name=only]:checked")].map((box) => box.value);
    let shown = 0;
    cards.forEach((card, i) => {
      const fits = only.every((name) => card.classList.contains(name)) && words.every((word) => texts[i].includes(word));
      card.hidden = !fits;
      shown += fits;
    });
    state.textContent = `${shown.toLocaleString("en")} of ${total.toLocaleString("en")} designs`;
    document.getElementById("none").hidden = shown > 0;
  }

  // Sort: unknown values last in either direction, equal ones in the order of the query.
  const keys = cards.map((card) => card.dataset.keys.split(",").map((key) => (key === "" ? null : Number(key))));
  const numbers = cards.map((_, i) => i);

  function sort(button) {
    const down = button.getAttribute("aria-pressed") === "true" && !button.classList.contains("down");
    for (const other of tools.querySelectorAll("[data-column]")) {
      other.setAttribute("aria-pressed", String(other === button));
      other.classList.toggle("down", other === button && down);
      other.textContent = other.textContent.replace(/ [\u2191\u2193]$/, "");
    }
    button.textContent += down ? " \u2193" : " \u2191";
    const column = Number(button.dataset.column);
    const order = [...numbers].sort((a, b) => {
      const [x, y] = [keys[a][column], keys[b][column]];
      if (x === null || y === null) return (x === null) - (y === null) || a - b;
      return (down ? y - x : x - y) || a - b;
    });
    gallery.append(...order.map((i) => cards[i]));
  }

  // Pictures: each path holds the pieces of one kind in circuit order, so a folding only deals them out anew.
  const KINDS = { m: "mountain", v: "valley", f: "flat", h: "hinge", p: "panel", o: "outer" };

  function deal(svg, before, after) {
    const path = (kind) => svg.querySelector("." + KINDS[kind]);
    const piles = {};
    for (const kind of new Set(before)) piles[kind] = path(kind).getAttribute("d").match(/M[^M]+/g);
    const pieces = [...before].map((kind) => piles[kind].shift());
    const dealt = {};
    [...after].forEach((kind, k) => { dealt[kind] = (dealt[kind] || "") + pieces[k]; });
    for (const kind of Object.keys(dealt)) path(kind).setAttribute("d", dealt[kind]);
    return pieces;
  }

  // Panel k lies before crease k; the outer layers are the panels beside the flat creases.
  const layers = (letters) =>
    [...letters].map((fold, k) => (fold === "f" || letters.at(k - 1) === "f" ? "o" : "p")).join("");

  function show(chip) {
    const card = chip.closest(".card");
    const old = card.querySelector(".fold[aria-pressed=true]");
    const svg = card.querySelector("svg");
    deal(svg, old.dataset.letters, chip.dataset.letters);
    deal(svg, layers(old.dataset.letters), layers(chip.dataset.letters));
    old.setAttribute("aria-pressed", "false");
    chip.setAttribute("aria-pressed", "true");
  }

  // The number of each crease, on its line but beside the circuit.
  function number(svg, letters) {
    const group = document.createElementNS(svg.namespaceURI, "g");
    group.setAttribute("class", "numbers");
    deal(svg, letters, letters).forEach((piece, k) => {
      const [x, y, dx, dy] = piece.match(/-?\d+/g).map(Number);
      const text = document.createElementNS(svg.namespaceURI, "text");
      text.setAttribute("x", Math.round(x + 0.28 * dx));
      text.setAttribute("y", Math.round(y + 0.28 * dy + 7));
      text.textContent = k;
      group.append(text);
    });
    svg.append(group);
  }

  function enlarge(card) {
    const copy = document.createElement("div");
    copy.className = "card";
    copy.append(...card.cloneNode(true).childNodes);
    const svg = copy.querySelector("svg");
    const fold = copy.querySelector(".fold[aria-pressed=true]");
    if (svg) number(svg, fold ? fold.dataset.letters : "h".repeat(svg.querySelector(".hinge").getAttribute("d").split("M").length - 1));
    const close = document.createElement("button");
    close.type = "button";
    close.className = "copy close";
    close.textContent = "close";
    copy.querySelector("header").append(close);
    large.replaceChildren(copy);
    large.showModal();
  }

  async function copy(button) {
    const text = button.parentElement.querySelector("code").textContent;
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // Pages opened from a file may be refused the clipboard: select the text instead.
      getSelection().selectAllChildren(button.parentElement.querySelector("code"));
      document.execCommand("copy");
    }
    button.textContent = "copied";
    setTimeout(() => { button.textContent = "copy"; }, 1200);
  }

  document.addEventListener("click", (event) => {
    const button = event.target.closest("button");
    if (event.target === large || button?.classList.contains("close")) large.close();
    else if (!button) return;
    else if (button.dataset.column) sort(button);
    else if (button.dataset.letters) show(button);
    else if (button.classList.contains("copy")) copy(button);
    else if (button.classList.contains("thumb") && !large.open) enlarge(button.closest(".card"));
  });
  tools.addEventListener("input", filter);
  tools.addEventListener("submit", (event) => event.preventDefault());
  tools.hidden = false;
  filter();
})();
