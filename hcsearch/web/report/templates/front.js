// The Pareto front of points by two criteria, as `hcsearch rank` marks it.
const Front = (() => {
  // The points that no other exceeds in one criterion without being behind it in the other; equal ones are on it together.
  // points : {x, y, deployable}. Those known not to deploy are left out. signs : 1 where higher is better, -1 where lower is.
  function of(points, signX, signY) {
    const sorted = points.filter(({ deployable }) => deployable !== 0)
      .sort((a, b) => signX * (b.x - a.x) || signY * (b.y - a.y));
    const front = new Set();
    let best = -Infinity, last = null;
    for (const point of sorted) {
      const worth = signY * point.y;
      if (worth > best || (last && worth === best && point.x === last.x)) {
        front.add(point);
        last = point;
        best = worth;
      }
    }
    return front;
  }

  return { of };
})();
