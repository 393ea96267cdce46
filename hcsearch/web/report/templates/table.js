// The data of the page: columns of designs and of foldings, unpacked once.
const Table = (() => {
  const unpack = (column, count) => {
    if (Array.isArray(column)) return column;
    if (column.words) return column.at.map((place) => column.words[place]);
    return Array(count).fill(column.all);
  };

  // The status of a design; where no stage has given a verdict, what is known of it.
  function statusOf({ status, untwisted, two_stack: stacks }) {
    if (status !== null) return status;
    if (untwisted !== null) return untwisted ? "untwisted" : stacks ? "twisted" : "no_folding";
    if (stacks !== null) return stacks ? "two_stack" : "no_folding";
    return "not_judged";
  }

  function read(data) {
    const quantities = new Map(data.quantities.map((quantity) => [quantity.name, quantity]));
    const designs = {}, foldings = {};
    for (const name of quantities.keys()) designs[name] = unpack(data.designs[name], data.count);
    const none = Array(data.count).fill(null);
    for (const name of ["id", "untwisted", "two_stack", "status", "circuit", "array"]) designs[name] ||= none;
    const readable = unpack(data.readable, data.count), best = unpack(data.best, data.count);
    const of = Array.from({ length: data.count }, () => []);
    for (const [name, column] of Object.entries(data.foldings)) foldings[name] = unpack(column, data.folding_count);
    foldings.design.forEach((design, row) => of[design].push(row));
    const status = designs.status.map((word, i) => statusOf({ status: word, untwisted: designs.untwisted[i], two_stack: designs.two_stack[i] }));
    const texts = [];
    const text = (i) => (texts[i] ??= [`#${designs.id[i]}`, designs.circuit[i], designs.array[i], status[i].replace("_", " ")]
      .join(" ").toLowerCase());
    const row = (i, crease) => of[i].find((k) => foldings.crease[k] === crease);
    return {
      ...data, designs, foldings, readable, best, status, text, row,
      quantity: (name) => quantities.get(name),
      rows: (i) => of[i],
      // The address of a design's page; empty where there is none.
      page: (i) => data.pages.replace("{id}", designs.id[i]),
      // The motion of a folding, or the address where it is.
      player: (k) => data.players[k] || null,
    };
  }

  // The numbers in which the designs differ, and the id.
  function sortable(table) {
    return table.quantities.filter(({ name, kind }) => kind !== "text"
      && (name === "id" || new Set(table.designs[name]).size > 1));
  }

  // The better end of a quantity comes first: its name, after `-` where the larger values are the better ones.
  const betterFirst = ({ name, better }) => (better === "higher" ? `-${name}` : name);

  // In the order of the query, best first, or by a name, after `-` the largest first; `-` alone turns the order around.
  // Unknown values come last either way, equal ones in the order of the query.
  function sorted(table, chosen, sort) {
    const down = sort.startsWith("-"), keys = table.designs[down ? sort.slice(1) : sort], sign = down ? -1 : 1;
    if (!keys) return down ? [...chosen].reverse() : chosen;
    return [...chosen].sort((a, b) => {
      const x = keys[a], y = keys[b];
      if (x === null || y === null) return (x === null) - (y === null) || a - b;
      return sign * (x - y) || a - b;
    });
  }

  return { read, statusOf, sortable, betterFirst, sorted };
})();
