// The condition `fits=`: whether the two stacks go into an envelope with parallel sides, as store/conditions.py has it.
const Envelopes = (() => {
  const NAME = "fits", SIDES = ["stowed_length", "stowed_width", "stowed_height"];
  const TOLERANCE_MM = 1e-6; // the rounding of these columns
  const LENGTH = "([0-9]{1,7}(?:\\.[0-9]{1,6})?)", BOX = new RegExp(`^${LENGTH}x${LENGTH}x${LENGTH}$`);

  const falling = (sides) => [...sides].sort((a, b) => b - a);

  // The sides of an envelope in mm, the longest first. catalogue : sides by name.
  function sidesOf(catalogue, text) {
    const known = Object.entries(catalogue).find(([name]) => name.toLowerCase() === text.toLowerCase());
    if (known) return known[1];
    const lengths = (BOX.exec(text) || []).slice(1).map(Number);
    if (!lengths.length || lengths.includes(0)) {
      throw new Error(`there is no envelope “${text}”: write one of ${Object.keys(catalogue).join(", ")}, or three lengths in mm, such as 100x100x340`);
    }
    return falling(lengths);
  }

  // Whether each design satisfies a condition; null where its stowed box is not known.
  function fitted(table, { sign, value, text }) {
    if (!["=", "!="].includes(sign) || !value) throw new Error(`“${text}” names no envelope by = or !=: write fits=3U, or fits=340x640x130 in mm`);
    const rooms = sidesOf(table.envelopes, value), columns = SIDES.map((name) => table.designs[name]);
    return (i) => {
      const sides = columns.map((column) => column[i]);
      if (sides.includes(null)) return null;
      return falling(sides).every((side, k) => side <= rooms[k] + TOLERANCE_MM) === (sign === "=");
    };
  }

  return { NAME, fitted };
})();
