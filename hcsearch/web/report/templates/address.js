// What is shown, as the part of the address after `#`: a link leads to it, and the browser's button leads back.
const Address = (() => {
  function read() {
    return Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
  }

  // The address with some values changed; empty values are left out.
  function changed(values) {
    const all = Object.entries({ ...read(), ...values }).filter(([, value]) => value !== "");
    return all.length ? `#${new URLSearchParams(all)}` : location.pathname + location.search;
  }

  // In place of the present entry of the browser's history.
  function replace(values) {
    history.replaceState(history.state, "", changed(values));
  }

  // As a new entry, which `back` leaves.
  function enter(values) {
    history.pushState({ entered: true }, "", changed(values));
  }

  // Out of what `enter` entered, or of what a link from elsewhere led to, where only the values are removed.
  function leave(values) {
    if (history.state?.entered) history.back();
    else replace(values);
  }

  const list = (text) => (text || "").split(",").filter(Boolean);

  return { read, replace, enter, leave, list };
})();
