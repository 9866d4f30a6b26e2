"""The live view: what a viewer shows, what a person asks for, and the page in the browser."""
