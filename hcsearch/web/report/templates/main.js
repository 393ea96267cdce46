const table = Table.read(JSON.parse(document.getElementById("data").textContent));
const byId = (name) => document.getElementById(name);
const [tools, find, state, large, column, direction, shape, facets, chooser] = [
  "tools", "find", "state", "large", "column", "direction", "shape", "facets", "columns"].map(byId);
const grouped = (count) => count.toLocaleString("en");
let sort = "", chosen = {}, shown = [];

const places = { cards: byId("gallery"), table: byId("rows") };
const refresh = (i) => view().refresh(i);
const dialog = Dialog.listen(table, byId("gallery"), large, { refresh, order: () => shown });
const views = {
  cards: Gallery.open(table, places.cards),
  table: Rows.open(table, places.table, sortBy, (i) => dialog.open([i])),
};
const view = () => views[shape.value];
const numbers = Table.sortable(table);
const plot = Plotting.listen(byId("scatter"), numbers.filter(({ name, kind }) => name !== "id" && kind !== "boolean"), points,
  (designs) => dialog.open([designs[0]], designs));

function points(x, y) {
  const { designs } = table;
  return shown.map((i) => ({ design: i, x: designs[x.name][i], y: designs[y.name][i], name: `#${designs.id[i]}`,
    status: table.status[i], deployable: designs.deployable?.[i] ?? null }));
}

function select() {
  let fitting;
  try {
    fitting = Conditions.selected(table, find.value);
  } catch (error) {
    // What was shown stays, beside what is wrong with the words.
    find.setAttribute("aria-invalid", "true");
    byId("wrong").textContent = error.message;
    return;
  }
  find.removeAttribute("aria-invalid");
  byId("wrong").textContent = "";
  Facets.show(table, facets, fitting, chosen);
  shown = Table.sorted(table, fitting.filter((i) => Facets.fits(table, chosen, i)), sort);
  view().show(shown, sort);
  state.textContent = `${grouped(shown.length)} of ${grouped(table.total)} designs`;
  byId("none").hidden = shown.length > 0;
  plot.draw();
}

// The direction of the order in words; without a column the order is that of the query, best first.
function direct() {
  const down = sort.startsWith("-"), words = column.value ? ["Smallest first", "Largest first"] : ["Best first", "Worst first"];
  direction.textContent = down ? "↓" : "↑";
  direction.setAttribute("aria-label", words[Number(down)]);
}

function sortBy(order) {
  sort = order;
  column.value = sort.replace("-", "");
  direct();
  select();
  remember();
}

// As cards or as a table.
function arrange() {
  for (const [name, place] of Object.entries(places)) place.hidden = name !== shape.value;
  const name = shape.value === "table" ? "Columns" : "Numbers on the cards";
  chooser.setAttribute("aria-label", name);
  chooser.previousElementSibling.textContent = name;
  view().show(shown, sort);
  view().layout();
}

function remember() {
  const values = Object.fromEntries(Facets.NAMES.map((name) => [name, (chosen[name] || []).join(",")]));
  Address.replace({ ...values, q: find.value, sort, columns: Columns.names(table),
    as: shape.value === "table" ? "table" : "" });
}

// What the address says.
function follow() {
  const told = Address.read(), name = (told.sort || "").replace("-", "");
  sort = !name || numbers.some((one) => one.name === name) ? told.sort || "" : "";
  find.value = told.q || "";
  column.value = sort.replace("-", "");
  chosen = Object.fromEntries(Facets.NAMES.map((facet) => [facet, Address.list(told[facet])]));
  const before = Columns.names(table);
  Columns.choose(table, Address.list(told.columns));
  Columns.check(chooser);
  plot.follow();
  direct();
  const as = told.as === "table" ? "table" : "cards", same = as === shape.value;
  shape.value = as;
  select();
  if (!same) arrange();
  else if (Columns.names(table) !== before) view().layout();
}

tools.addEventListener("submit", (event) => event.preventDefault());
find.addEventListener("input", () => { select(); remember(); });
column.addEventListener("input", () => sortBy(column.value && Table.betterFirst(table.quantity(column.value))));
direction.addEventListener("click", () => sortBy(sort.startsWith("-") ? sort.slice(1) : `-${sort}`));
shape.addEventListener("input", () => { arrange(); remember(); });
facets.addEventListener("click", (event) => {
  const button = event.target.closest("[data-facet]");
  if (!button) return;
  chosen = Facets.toggled(chosen, button);
  select();
  remember();
});
chooser.addEventListener("change", () => {
  Columns.take(chooser);
  view().layout();
  remember();
});
addEventListener("popstate", follow);
const folded = byId("numbers");
let opened = false;
addEventListener("beforeprint", () => {
  [opened, folded.open] = [folded.open, true];
  const printed = view().print(true);
  byId("printed").textContent = printed < shown.length ? `The first ${grouped(printed)} of ${grouped(shown.length)} designs are printed.` : "";
});
addEventListener("afterprint", () => {
  folded.open = opened;
  view().print(false);
});

column.append(...numbers.map(({ name, label, note }) => Parts.element("option", { value: name, title: note }, label)));
Columns.fill(table, chooser);
tools.hidden = false;
follow();
Compare.listen(table, byId("listed"), byId("compare"), dialog, refresh);
arrange();
if (table.count) First.show(table, table.first, byId("first"));
dialog.follow();
