const table = Table.read(JSON.parse(document.getElementById("data").textContent));
const byId = (name) => document.getElementById(name);
const [tools, find, state, large, column, direction] = ["tools", "find", "state", "large", "column", "direction"].map(byId);
const gallery = Gallery.open(table, byId("gallery"));
const spaced = (count) => count.toLocaleString("en");
let down = false;

function select() {
  const only = [...tools.querySelectorAll("input[name=only]:checked")].map((box) => box.value);
  let chosen;
  try {
    chosen = Conditions.selected(table, find.value).filter((i) => only.every((name) => table.designs[name][i]));
  } catch (error) {
    // What was shown stays, beside what is wrong with the words.
    find.setAttribute("aria-invalid", "true");
    byId("wrong").textContent = error.message;
    return;
  }
  find.removeAttribute("aria-invalid");
  byId("wrong").textContent = "";
  gallery.show(column.value ? Table.sorted(table, chosen, column.value, down) : down ? chosen.reverse() : chosen);
  state.textContent = `${spaced(chosen.length)} of ${spaced(table.total)} designs`;
  byId("none").hidden = chosen.length > 0;
}

function flip() {
  down = !down;
  direction.textContent = down ? "↓" : "↑";
  direction.setAttribute("aria-label", down ? "Largest first" : "Smallest first");
  select();
}

Dialog.listen(table, byId("gallery"), large, (i) => gallery.refresh(i));
direction.addEventListener("click", flip);
tools.addEventListener("input", select);
tools.addEventListener("submit", (event) => event.preventDefault());
addEventListener("beforeprint", () => {
  const printed = gallery.print(true);
  byId("printed").textContent = printed < gallery.count() ? `The first ${spaced(printed)} of ${spaced(gallery.count())} designs are printed.` : "";
});
addEventListener("afterprint", () => gallery.print(false));

column.append(...Table.sortable(table).map(({ name, label, note }) => Parts.element("option", { value: name, title: note }, label)));
tools.hidden = false;
select();
gallery.layout();
