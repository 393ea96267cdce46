// Names for screen readers that the theme leaves out.
for (const button of document.querySelectorAll(".search-button-field")) {
  button.removeAttribute("aria-label"); // it contradicts the text of the button
}
for (const toggle of document.querySelectorAll("summary:has(> .toctree-toggle)")) {
  const link = toggle.closest("li").querySelector("a");
  toggle.setAttribute("aria-label", `Pages below ${link.textContent.trim()}`);
}
