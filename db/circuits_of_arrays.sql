-- Arrays by their number of Hamiltonian circuits: all of them on the array, and up to its symmetry.
SELECT grid, n, "array", sum(orbit_size) AS all_circuits, count(*) AS circuits, sum(untwisted) AS untwisted
FROM designs
GROUP BY grid, n, "array"
ORDER BY all_circuits DESC, "array"
LIMIT 100;
