-- The runs, latest first, with what they found and how much of the work was there already.
SELECT id, started, finished, grid, n, target, keep, until, circuits, untwisted, batches_done, batches_reused
FROM runs
ORDER BY id DESC;
