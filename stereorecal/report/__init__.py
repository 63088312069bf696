"""Tables, figures and HTML pages from plain data; this package knows nothing of the rest of the library."""
