// The design that plays when the page opens; until its motion is there, its picture stands in its place.
const First = (() => {
  const { element } = Parts;

  function show(table, i, section) {
    const row = table.row(i, Card.drawn(table, i)), place = section.querySelector(".player");
    const motion = Motions.known(table, row), reason = row === undefined ? null : table.foldings.why[row];
    section.querySelector(".about").replaceChildren(
      element("p", { class: "named" }, element("strong", {}, `#${table.designs.id[i]}`), Parts.badge(table.status[i])),
      ...(motion ? [element("div", { class: "thumb" }, Parts.picture(table, i, Card.drawn(table, i)))] : []),
      ...(reason ? [element("p", { class: "why" }, reason)] : []),
      Parts.facts(table, i, row, Columns.shown),
      Parts.code("circuit notation", table.designs.circuit[i]),
      element("button", { type: "button", class: "chip large", "data-design": i }, "picture, foldings and numbers"));
    if (!place.firstElementChild) place.append(Parts.picture(table, i, Card.drawn(table, i)));
    if (motion) Motions.mount(table, row, place, { autoplay: true }, () => true);
  }

  return { show };
})();
