-- Designs with two untwisted foldings on neighbouring creases: the cut can be moved by one panel.
SELECT d.id, d.grid, d.n, a.crease AS crease, b.crease AS next_crease, d.circuit
FROM foldings AS a
JOIN designs AS d ON d.id = a.design_id
JOIN foldings AS b ON b.design_id = a.design_id AND b.crease = (a.crease + 1) % (d.n / 2)
WHERE a.untwisted = 1 AND b.untwisted = 1 AND b.crease <> a.crease
ORDER BY d.id, a.crease
LIMIT 100;
