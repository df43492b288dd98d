"""The study's numbers as tables, for a page of Markdown or HTML."""
