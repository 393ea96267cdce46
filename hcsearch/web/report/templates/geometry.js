// Pictures of circuits and foldings: the same integers as `drawing.py` writes, from a notation and a flat crease.
const Geometry = (() => {
  const MARGIN = 8;
  const KINDS = ["flat", "hinge", "mountain", "valley"];

  // Python rounds halves to even.
  const rounded = (value) => {
    const near = Math.round(value);
    return near - value === 0.5 && near % 2 ? near - 1 : near;
  };

  // The steps of a notation: a letter before the digits names the kind of the first panel.
  function steps(grid, text) {
    const kind = /^[a-z]/.test(text) ? text.charCodeAt(0) - 97 : 0;
    let frame = grid.frames[kind];
    return [...text.slice(kind ? 1 : 0)].map((digit) => {
      const [step, next] = grid.digits[frame][Number(digit)];
      frame = next;
      return step;
    });
  }

  function points(grid, word) {
    let [x, y] = grid.places[grid.kinds[word[0]]];
    return word.map((step) => {
      const here = [x, y];
      x += grid.steps[step][0];
      y += grid.steps[step][1];
      return here;
    });
  }

  const position = ({ unit: [a, b] }, [x, y]) => [a[0] * x + b[0] * y, a[1] * x + b[1] * y];

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

  // Width, height, [class, path data] of each path in the order they are drawn, and the creases as segments.
  function picture(grids, notation, crease, size) {
    const [name, text] = notation.split(":");
    const grid = grids[name], word = steps(grid, text), n = word.length, kinds = word.map((step) => grid.kinds[step]);
    let [length, width] = size || (name === "rectangle" ? [50, 40] : [1, 1]);
    if (!grid.rectangular) length = width = 1;
    const scale = grid.side / Math.min(length, width);
    const places = points(grid, word);
    const corners = places.map((p, k) => {
      const [cx, cy] = position(grid, p);
      return grid.corners[kinds[k]].map(([x, y]) => [scale * length * (cx + x), -scale * width * (cy + y)]);
    });
    const all = corners.flat();
    const left = Math.min(...all.map((p) => p[0])) - MARGIN, top = Math.min(...all.map((p) => p[1])) - MARGIN;
    const pixel = ([x, y]) => [rounded(x - left), rounded(y - top)];
    const panels = corners.map((panel) => panel.map(pixel));
    const centres = places.map((p) => position(grid, p)).map(([x, y]) => pixel([scale * length * x, -scale * width * y]));
    const key = (i, j) => Math.min(i, j) * n + Math.max(i, j);
    const at = new Map(places.map((p, k) => [p.join(), k])), edges = new Map();
    places.forEach((p, k) => grid.leaving[kinds[k]].forEach((step, side) => {
      const to = at.get([p[0] + grid.steps[step][0], p[1] + grid.steps[step][1]].join());
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
      ...KINDS.map((kind) => [kind, creases.filter((_, k) => folds[k] === kind), false]),
      ["slit", [...edges.values()], false],
    ];
    const extent = (axis) => Math.max(...panels.flat().map((p) => p[axis])) + MARGIN;
    return {
      width: extent(0),
      height: extent(1),
      paths: drawn.filter(([, lines]) => lines.length).map(
        ([kind, lines, closed]) => [kind, lines.map((line) => subpath(line, closed)).join("")]),
      creases,
      start: centres[0],
    };
  }

  return { picture, rounded };
})();
