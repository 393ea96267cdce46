// Names for screen readers that the theme leaves out.
for (const button of document.querySelectorAll(".search-button-field")) {
  button.setAttribute("aria-label", button.textContent.replace(/\s+/g, " ").trim()); // the shortcut, too, which it shows
}
for (const toggle of document.querySelectorAll("summary:has(> .toctree-toggle)")) {
  const link = toggle.closest("li").querySelector("a");
  toggle.setAttribute("aria-label", `Pages below ${link.textContent.trim()}`);
}
