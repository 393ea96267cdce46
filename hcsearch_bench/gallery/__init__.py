"""The gallery of the documentation: pictures, and the page that shows them with their commands."""
