"""What is written of a run: a page that stands alone, pictures, numbers as JSON, and the page of the docs."""
