// Pictures of circuits and foldings: the same integers as `drawing.py` writes, from a notation and a flat crease.
const Geometry = (() => {
  const SIDE = 100, MARGIN = 8;
  const FOLDS = ["flat", "hinge", "mountain", "valley"];

  // Python rounds halves to even; sums in another order may leave a half a little beside it.
  const rounded = (value) => {
    const exact = Math.round(1e6 * value) / 1e6, near = Math.round(exact);
    return near - exact === 0.5 && near % 2 ? near - 1 : near;
  };

  // The steps that a notation names: its digits, after a letter for the kind of the first panel if that is not `a`.
  function word(grid, text) {
    const letter = text[0] >= "a";
    let frame = grid.first[letter ? text.charCodeAt(0) - 97 : 0];
    return [...text.slice(letter ? 1 : 0)].map((digit) => {
      const step = grid.digits[frame][digit];
      frame = grid.after[frame][digit];
      return grid.steps[step];
    });
  }

  function points(steps) {
    let x = 0, y = 0;
    return steps.map(([, dx, dy]) => {
      const here = [x, y];
      x += dx;
      y += dy;
      return here;
    });
  }

  // The fold of each crease, as `Folding.assignment` has it; hinges of no known fold without a crease.
  function assignment(n, crease) {
    const folds = Array(n).fill("hinge");
    if (crease === null) return folds;
    for (let t = -1; t < n / 2; t++) {
      const fold = t % 2 ? "mountain" : "valley";
      folds[(crease + 1 + t + n) % n] = fold;
      folds[(crease - 1 - t + 2 * n) % n] = fold;
    }
    folds[crease] = folds[crease + n / 2] = "flat";
    return folds;
  }

  const subpath = (line, closed) => {
    const numbers = line.map((p, k) => (k ? [p[0] - line[k - 1][0], p[1] - line[k - 1][1]] : p));
    const [first, ...steps] = numbers.map((pair) => pair.map((v) => (v >= 0 ? " " + v : String(v))).join(""));
    return `M${first.trimStart()}l${steps.join("").trimStart()}${closed ? "z" : ""}`;
  };

  // Width, height, sides of a panel, [class, path data] of each path as they are drawn, and the creases as segments.
  function picture(grids, notation, crease, size) {
    const [name, text] = notation.split(":");
    const grid = grids[name], steps = word(grid, text), places = points(steps), n = steps.length;
    const [length, width] = (grid.size && size) || grid.size || [1, 1];
    const scale = SIDE / Math.min(length, width), [[ax, ay], [bx, by]] = grid.axes;
    const position = ([x, y]) => [scale * length * (x * ax + y * bx), -scale * width * (x * ay + y * by)];
    const corners = places.map(([x, y], k) => grid.corners[steps[k][0]].map(([dx, dy]) => position([x + dx, y + dy])));
    const all = corners.flat();
    const left = Math.min(...all.map((p) => p[0])) - MARGIN, top = Math.min(...all.map((p) => p[1])) - MARGIN;
    const pixel = ([x, y]) => [rounded(x - left), rounded(y - top)];
    const panels = corners.map((panel) => panel.map(pixel));
    const centres = places.map((p) => pixel(position(p)));
    const key = (i, j) => Math.min(i, j) * n + Math.max(i, j);
    const at = new Map(places.map((p, k) => [p.join(), k])), edges = new Map();
    places.forEach(([x, y], k) => grid.steps.filter(([kind]) => kind === steps[k][0]).forEach(([, dx, dy], side) => {
      const to = at.get([x + dx, y + dy].join());
      if (to > k) edges.set(key(k, to), [panels[k][side], panels[k][(side + 1) % panels[k].length]]);
    }));
    const creases = places.map((_, k) => {
      const own = key(k, (k + 1) % n), edge = edges.get(own);
      edges.delete(own);
      return edge;
    });
    const folds = assignment(n, crease);
    const outer = panels.map((_, k) => folds[k] === "flat" || folds[(k + n - 1) % n] === "flat");
    const drawn = [
      ["panel", panels.filter((_, k) => !outer[k]), true],
      ["outer", panels.filter((_, k) => outer[k]), true],
      ["circuit", [centres], true],
      ...FOLDS.map((kind) => [kind, creases.filter((_, k) => folds[k] === kind), false]),
      ["slit", [...edges.values()], false],
    ];
    const extent = (axis) => Math.max(...panels.flat().map((p) => p[axis])) + MARGIN;
    return {
      width: extent(0),
      height: extent(1),
      sides: panels[0].length,
      paths: drawn.filter(([, lines]) => lines.length).map(
        ([kind, lines, closed]) => [kind, lines.map((line) => subpath(line, closed)).join("")]),
      creases,
      start: centres[0],
    };
  }

  return { picture, rounded };
})();
