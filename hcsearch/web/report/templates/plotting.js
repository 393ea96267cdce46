// The scatter plot with the choice of its two numbers, which stand in the address.
const Plotting = (() => {
  const USUAL = [["deploy_time", "needed_margin"], ["needed_margin", "dof"], ["symmetry", "n_foldings"]];

  // place : with two selects and a figure. quantities : to choose from. points : of two quantities, perhaps later.
  // open : shows designs. Without two quantities there is no plot.
  function listen(place, quantities, points, open) {
    const [across, up] = place.querySelectorAll("select"), figure = place.querySelector("figure");
    const named = (name) => quantities.find((quantity) => quantity.name === name);
    const usual = USUAL.find((pair) => pair.every(named)) || quantities.map(({ name }) => name).slice(-2);
    for (const select of [across, up]) {
      select.append(...quantities.map(({ name, label, note }) => Parts.element("option", { value: name, title: note }, label)));
    }
    place.hidden = quantities.length < 2;
    const nothing = () => {};
    let asked = 0, redraw = nothing; // what is shown, in another width

    async function draw() {
      if (!place.open || place.hidden) return;
      const own = ++asked, [x, y] = [named(across.value), named(up.value)];
      redraw = nothing;
      let found;
      try {
        found = await points(x, y);
      } catch (error) {
        if (own === asked) figure.replaceChildren(Parts.element("p", { class: "nothing" }, error.message));
        return;
      }
      if (own !== asked) return;
      redraw = () => Scatter.draw(figure, found, x, y, open);
      redraw();
    }

    // What the address says.
    function follow() {
      const { x, y } = Address.read();
      [across.value, up.value] = [named(x) ? x : usual[0], named(y) ? y : usual.at(-1)];
      if (x || y) place.open = true;
    }

    place.addEventListener("change", (event) => {
      event.stopPropagation();
      Address.replace({ x: across.value, y: up.value });
      draw();
    });
    place.addEventListener("toggle", () => {
      if (!place.open) Address.replace({ x: "", y: "" });
      draw();
    });
    let width = 0;
    new ResizeObserver(() => {
      if (figure.clientWidth === width) return;
      width = figure.clientWidth;
      redraw();
    }).observe(figure);
    return { draw, follow };
  }

  return { listen };
})();
