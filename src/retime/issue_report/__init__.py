"""What `retime report` attaches to an issue: a file without its names that still behaves in the same way."""
