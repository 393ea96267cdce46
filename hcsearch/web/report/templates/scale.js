// Axes of plots: round ticks over a range, and a linear scale.
const Scale = (() => {
  const TICKS = 6;

  // Steps of 1, 2 or 5 times a power of ten; whole : only whole numbers.
  function step(span, whole) {
    const power = 10 ** Math.floor(Math.log10(span / TICKS));
    const wide = [1, 2, 5, 10].map((factor) => factor * power).find((size) => span / size <= TICKS);
    return whole ? Math.max(1, wide) : wide;
  }

  // values : at least one. Returns ends, ticks, and the place of a value between two places.
  function over(values, whole) {
    let low = Infinity, high = -Infinity;
    for (const value of values) {
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    const half = high > low ? 0 : Math.max(0.5, 0.1 * Math.abs(high));
    const size = step(high - low + 2 * half, whole);
    const first = Math.floor((low - half) / size), last = Math.ceil((high + half) / size);
    const ticks = Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * size).toPrecision(12)));
    const [begin, end] = [ticks[0], ticks.at(-1)];
    return { ticks, place: (value, from, to) => from + ((value - begin) / (end - begin)) * (to - from) };
  }

  return { over };
})();
