-- How much the foldings of each grid and size are twisted.
SELECT d.grid, d.n, f.twist, count(*) AS foldings, count(DISTINCT d.id) AS designs
FROM foldings AS f
JOIN designs AS d ON d.id = f.design_id
GROUP BY d.grid, d.n, f.twist
ORDER BY d.grid, d.n, f.twist;
