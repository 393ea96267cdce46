// The cards of one page of designs, as the report draws them.
const table = Table.read(JSON.parse(document.getElementById("data").textContent));
const byId = (name) => document.getElementById(name);
const gallery = byId("gallery"), compare = byId("compare"), first = byId("first");
const MOST_POINTS = 20000;
const index = new Map(table.designs.id.map((id, i) => [id, i]));
Columns.choose(table, Address.list(gallery.dataset.columns));
const cards = Array.from({ length: table.count }, (_, i) => Card.make(table, i));
const order = cards.map((_, i) => i);
gallery.append(...cards);

const dialog = Dialog.listen(table, gallery, byId("large"), { refresh: (i) => Card.fill(table, i, cards[i]), order: () => order });
Compare.listen(table, gallery, compare, dialog, (i) => Card.fill(table, i, cards[i]));

// The designs of the whole list as points of the plot.
async function points(x, y) {
  const address = new URL(gallery.dataset.rows, location.href);
  const columns = new Set(["id", "status", "deployable", "untwisted", "two_stack", x.name, y.name]);
  for (const [name, value] of [["sort", "id"], ["columns", [...columns].join(",")], ["limit", MOST_POINTS]]) address.searchParams.set(name, value);
  const answer = await fetch(address);
  if (!answer.ok) throw new Error("The numbers cannot be read right now: choose again in a few seconds.");
  return (await answer.json()).map((row) => ({ design: row.id, x: row[x.name], y: row[y.name], name: `#${row.id}`,
    status: Table.statusOf(row), deployable: row.deployable }));
}

// A design of this page is enlarged, another one has a page of its own.
function open(ids) {
  const here = ids.map((id) => index.get(id)).filter((i) => i !== undefined);
  if (here.length) dialog.open([here[0]], here);
  else location.assign(table.pages.replace("{id}", ids[0]));
}

const numeric = table.quantities.filter(({ name, kind }) => ["integer", "real"].includes(kind) && name !== "id");
const plot = Plotting.listen(byId("scatter"), numeric, points, open);
plot.follow();
if (first) First.show(table, table.first, first);
dialog.follow();
