"""Images: files, and which of them belong together."""
