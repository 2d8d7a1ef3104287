"""Reading and writing of files: bounded, atomic, every number with its unit."""
