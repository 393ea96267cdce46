// A scatter plot of designs over two numbers, one mark for all designs of a status at one place.
const Scatter = (() => {
  const { element, shape } = Parts;
  const HEIGHT = 380, LEFT = 68, RIGHT = 16, TOP = 12, BOTTOM = 50, SIZE = 5, REACH = 16;
  // Path of a mark around (0, 0) by status; other statuses are rings.
  const SHAPES = {
    deploys: "m-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0z",
    movable: "m0-6l6 6-6 6-6-6z",
    undecided: "m0-6l6 10h-12z",
    locked: "m-4.5-4.5h9v9h-9z",
    twisted: "m-4-4l8 8m0-8l-8 8",
    no_folding: "m-5 0h10m-5-5v10",
  };
  const RING = "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z", HALO = "m-9 0a9 9 0 1 0 18 0a9 9 0 1 0-18 0z";
  const sign = ({ better }) => ({ higher: 1, lower: -1 })[better];
  const named = ({ label, unit }) => label + (unit && ` (${unit})`);

  // Points at one place, in the order in which they came.
  function places(points) {
    const found = new Map();
    for (const point of points) {
      const key = `${point.x} ${point.y}`;
      if (!found.has(key)) found.set(key, { x: point.x, y: point.y, points: [] });
      found.get(key).points.push(point);
    }
    return [...found.values()];
  }

  const text = (content, x, y, attributes = {}) => shape("text", { x, y, ...attributes }, content);

  function axes(svg, width, x, y, across, up) {
    const bottom = HEIGHT - BOTTOM;
    const lines = [...across.ticks.map((tick) => `M${across.place(tick, LEFT, width - RIGHT)} ${TOP}V${bottom}`),
      ...up.ticks.map((tick) => `M${LEFT} ${up.place(tick, bottom, TOP)}H${width - RIGHT}`)];
    svg.append(shape("path", { class: "lines", d: lines.join("") }),
      ...across.ticks.map((tick) => text(tick, across.place(tick, LEFT, width - RIGHT), bottom + 18, { "text-anchor": "middle" })),
      ...up.ticks.map((tick) => text(tick, LEFT - 8, up.place(tick, bottom, TOP) + 4, { "text-anchor": "end" })),
      text(named(x), (LEFT + width - RIGHT) / 2, HEIGHT - 8, { "text-anchor": "middle", class: "axis" }),
      text(named(y), 0, 0, { "text-anchor": "middle", class: "axis", transform: `translate(16 ${(TOP + bottom) / 2}) rotate(-90)` }));
  }

  function legend(statuses, front) {
    const mark = (kind, d) => {
      const svg = shape("svg", { viewBox: "-10 -10 20 20", width: 18, height: 18, "aria-hidden": "true" });
      svg.append(shape("path", { class: kind, d: `M0 0${d}` }));
      return svg;
    };
    return element("ul", { class: "marks" },
      ...statuses.map((status) => element("li", {}, mark(`mark s-${status}`, SHAPES[status] || RING), Parts.spaced(status))),
      front ? element("li", {}, mark("front", HALO), front) : null);
  }

  function sentence(x, y, place, front) {
    const { points } = place, names = points.slice(0, 4).map(({ name }) => name).join(", ");
    const who = points.length === 1 ? `${names}, ${Parts.spaced(points[0].status)}`
      : `${points.length} designs: ${names}${points.length > 4 ? " and others" : ""}`;
    const on = points.some((point) => front.has(point)) ? "; on the Pareto front" : "";
    return `${who}: ${x.label} ${Parts.worded(x, place.x)}, ${y.label} ${Parts.worded(y, place.y)}${on}`;
  }

  // points : {x, y, name, status, deployable, design}, x and y null where they are not known. x, y : their quantities.
  // open : shows the designs of a place, given as `design` of its points.
  function draw(figure, points, x, y, open) {
    const known = points.filter((point) => point.x !== null && point.y !== null);
    const said = element("p", { class: "said", "aria-live": "polite" });
    const missing = points.length - known.length;
    const note = missing ? `${missing.toLocaleString("en")} of ${points.length.toLocaleString("en")} designs have no value of one of these numbers.` : "";
    if (!known.length) {
      figure.replaceChildren(element("p", { class: "nothing" }, note || "No design fits."));
      return;
    }
    const front = sign(x) && sign(y) ? Front.of(known, sign(x), sign(y)) : new Set();
    const width = Math.max(280, figure.clientWidth), all = places(known);
    const across = Scale.over(all.map((place) => place.x), x.kind === "integer");
    const up = Scale.over(all.map((place) => place.y), y.kind === "integer");
    for (const place of all) {
      place.px = across.place(place.x, LEFT, width - RIGHT);
      place.py = up.place(place.y, HEIGHT - BOTTOM, TOP);
    }
    const statuses = [...new Set(known.map(({ status }) => status))];
    const label = `Scatter plot of ${known.length} designs, ${named(x)} against ${named(y)}. Arrow keys go from place to place, Enter opens its designs.`;
    const svg = shape("svg", { class: "scatter", viewBox: `0 0 ${width} ${HEIGHT}`, width, height: HEIGHT, tabindex: 0,
      role: "application", "aria-roledescription": "plot", "aria-label": label });
    axes(svg, width, x, y, across, up);
    const at = (place, d) => `M${place.px.toFixed(1)} ${place.py.toFixed(1)}${d}`;
    for (const status of [...statuses].reverse()) { // the first ones lie on top
      const own = all.filter((place) => place.points.some((point) => point.status === status));
      svg.append(shape("path", { class: `mark s-${status}`, d: own.map((place) => at(place, SHAPES[status] || RING)).join("") }));
    }
    const best = all.filter((place) => place.points.some((point) => front.has(point)));
    svg.append(shape("path", { class: "front", d: best.map((place) => at(place, HALO)).join("") }));
    const cursor = shape("path", { class: "cursor", d: "" });
    svg.append(cursor);
    const words = front.size ? `on the Pareto front: ${x.better} ${x.label} and ${y.better} ${y.label} are better` : null;
    figure.replaceChildren(svg, said, legend(statuses, words), ...(note ? [element("p", { class: "note" }, note)] : []));
    listen(svg, all, (place) => {
      cursor.setAttribute("d", place ? at(place, HALO) : "");
      said.textContent = place ? sentence(x, y, place, front) : "";
    }, (place) => open(place.points.map(({ design }) => design)));
  }

  function listen(svg, all, mark, open) {
    const [rightwards, upwards] = [[...all].sort((a, b) => a.px - b.px || b.py - a.py), [...all].sort((a, b) => b.py - a.py || a.px - b.px)];
    let now = null;
    const go = (place) => { now = place; svg.style.cursor = place ? "pointer" : ""; mark(place); };

    function nearest(event) {
      const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
      const [px, py] = [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
      let found = null, least = (SIZE + REACH) ** 2;
      for (const place of all) {
        const distance = (place.px - px) ** 2 + (place.py - py) ** 2;
        if (distance < least) [found, least] = [place, distance];
      }
      return found;
    }

    svg.addEventListener("pointermove", (event) => go(nearest(event)));
    svg.addEventListener("pointerleave", () => go(null));
    svg.addEventListener("click", (event) => { go(nearest(event)); if (now) open(now); });
    svg.addEventListener("keydown", (event) => {
      const [line, by] = { ArrowRight: [rightwards, 1], ArrowLeft: [rightwards, -1], ArrowUp: [upwards, 1], ArrowDown: [upwards, -1],
        Home: [rightwards, -Infinity], End: [rightwards, Infinity] }[event.key] || [];
      if (line) {
        // without a place so far, forwards begins at the first one and backwards at the last
        const from = now ? line.indexOf(now) : by > 0 ? -1 : line.length;
        go(line[Math.min(line.length - 1, Math.max(0, from + by))]);
      } else if (event.key === "Enter" && now) open(now);
      else return;
      event.preventDefault();
    });
  }

  return { draw };
})();
