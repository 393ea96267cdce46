// The page of a design or an assembly: motions are mounted as they come near to what is seen, their plots move with
// them, and panels and hinges are pointed out in pictures, players and plots together. Exploded views stand in the address.
const motions = JSON.parse(document.getElementById("data").textContent);
const handles = new Map(); // of the places of players
const apart = new Set(Address.list(Address.read().exploded)); // numbers of the motions whose panels are drawn apart

const motionOf = (place) => motions[Number(place.dataset.motion)];
const plotsOf = (place) => [...place.closest(".motion").querySelectorAll("svg.plot")];
const foldingOf = (element) => element.closest(".folding");

function mount(place) {
  if (handles.has(place)) return;
  place.replaceChildren();
  const { at, labels } = motionOf(place), cursors = plotsOf(place).map(cursorOf);
  handles.set(place, hcsearchPlayer.mount(place, motionOf(place), {
    numbers: true,
    autoplay: "plays" in place.dataset,
    exploded: apart.has(place.dataset.motion),
    parted: (on) => keepApart(place.dataset.motion, on),
    moved: (now) => cursors.forEach((move) => move((now - at[0]) / (at.at(-1) - at[0] || 1))),
    pointed: (panel) => mark(foldingOf(place), panel === null ? {} : { panels: labels.panels[panel].split("+") }),
  }));
}

function keepApart(motion, on) {
  if (on) apart.add(motion);
  else apart.delete(motion);
  Address.replace({ exploded: [...apart].join(",") });
}

// The line in a plot that shows the place of its motion.
function cursorOf(plot) {
  const line = document.createElementNS(plot.namespaceURI, "path");
  const { left, right } = plot.dataset, { height } = plot.viewBox.baseVal;
  line.setAttribute("class", "cursor");
  line.setAttribute("d", `M0 10V${height - 42}`);
  plot.append(line);
  return (share) => line.setAttribute("transform", `translate(${Number(left) + share * (right - left)})`);
}

function seek(plot, clientX) {
  const place = plot.closest(".motion").querySelector(".player"), { at } = motionOf(place);
  const { left, width } = plot.getBoundingClientRect(), from = Number(plot.dataset.left), to = Number(plot.dataset.right);
  const share = ((clientX - left) * (plot.viewBox.baseVal.width / width) - from) / (to - from);
  mount(place);
  handles.get(place).seek(at[0] + Math.min(1, Math.max(0, share)) * (at.at(-1) - at[0]));
}

// Numbers of the labels that name one of some panels or creases; `4+5` names both.
const named = (labels, names) =>
  labels.flatMap((label, k) => (label.split("+").some((name) => names.includes(name)) ? [k] : []));

// Point out panels and hinges of a folding by their names; none in place of those before where nothing is named.
function mark(folding, { panels = [], hinges = [] }) {
  for (const shape of folding.querySelectorAll(".part")) {
    const { panel, hinge } = shape.dataset;
    shape.classList.toggle("on", panel === undefined ? hinges.includes(hinge) : panels.includes(panel));
  }
  for (const place of folding.querySelectorAll(".player")) {
    const { labels, hinges: joints } = motionOf(place);
    const marked = { panels: named(labels.panels, panels), hinges: named(labels.hinges, hinges) };
    handles.get(place)?.mark(marked);
    const drawn = joints.flatMap(([, , , , , , first, second], k) =>
      marked.hinges.includes(k) || marked.panels.includes(first) || marked.panels.includes(second) ? [k] : []);
    for (const curve of place.closest(".motion").querySelectorAll("[data-hinges]")) {
      const own = curve.dataset.hinges.split(" ").map(Number);
      curve.classList.toggle("off", drawn.length > 0 && !own.some((k) => drawn.includes(k)));
    }
  }
}

// What an element of a folding names; null where it names nothing.
function namedBy(element) {
  const part = element.closest(".part");
  if (part) return "panel" in part.dataset ? { panels: [part.dataset.panel] } : { hinges: [part.dataset.hinge] };
  const curve = element.closest("[data-hinges]");
  if (!curve) return null;
  const { labels } = motionOf(curve.closest(".motion").querySelector(".player"));
  return { hinges: curve.dataset.hinges.split(" ").flatMap((k) => labels.hinges[k].split("+")) };
}

// The list from which a panel or a hinge is pointed out without a pointer.
function fillPick(pick) {
  const select = pick.querySelector("select");
  const names = (kind) => [...foldingOf(pick).querySelectorAll(`.part[data-${kind}]`)].map((part) => part.dataset[kind]);
  for (const [kind, word] of [["panel", "panel"], ["hinge", pick.dataset.hinge]])
    select.append(...names(kind).map((name) => new Option(`${word} ${name}`, `${kind} ${name}`)));
  select.addEventListener("change", () => {
    const [kind, name] = select.value.split(" ");
    mark(foldingOf(pick), kind ? { [`${kind}s`]: [name] } : {});
  });
  pick.hidden = false;
}

const places = [...document.querySelectorAll(".player")];
const near = new IntersectionObserver((entries) => {
  for (const { isIntersecting, target } of entries) if (isIntersecting) mount(target);
}, { rootMargin: "300px" });
places.forEach((place) => near.observe(place));
document.querySelectorAll(".pick").forEach(fillPick);

for (const folding of document.querySelectorAll(".folding")) {
  for (const kind of ["pointerover", "focusin"]) folding.addEventListener(kind, ({ target }) => {
    const what = namedBy(target);
    if (what) mark(folding, what);
  });
  for (const kind of ["pointerout", "focusout"]) folding.addEventListener(kind, ({ target }) => {
    if (namedBy(target)) mark(folding, {});
  });
}
for (const plot of document.querySelectorAll(".motion svg.plot")) {
  plot.addEventListener("pointerdown", (event) => {
    plot.setPointerCapture(event.pointerId);
    seek(plot, event.clientX);
  });
  plot.addEventListener("pointermove", (event) => {
    if (event.buttons) seek(plot, event.clientX);
  });
}

let folded = []; // what was closed before printing
addEventListener("beforeprint", () => {
  folded = [...folded, ...document.querySelectorAll("details:not([open])")];
  for (const part of folded) part.open = true;
  if (places.every((place) => handles.has(place))) return;
  places.forEach(mount);
  dispatchEvent(new Event("beforeprint")); // again, for the players that were not there: each draws its stills
});
addEventListener("afterprint", () => {
  for (const part of folded) part.open = false;
  folded = [];
});

document.addEventListener("click", (event) => {
  const button = event.target.closest(".copy");
  if (button) copy(button);
});
