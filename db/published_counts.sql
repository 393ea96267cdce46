-- Designs of each grid and size, with the numbers that the literature counts: fixed circuits (self-avoiding polygons).
-- Complete only for sizes that were enumerated over all arrays with `--keep all`.
SELECT grid, n, count(*) AS circuits, sum(n_fixed) AS fixed_circuits, count(DISTINCT "array") AS arrays,
       sum(two_stack) AS two_stack, sum(untwisted) AS untwisted, sum(deployable) AS deployable
FROM designs
GROUP BY grid, n
ORDER BY grid, n;
