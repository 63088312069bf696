"""The exit codes of every command."""

REPAIR, BAD_INPUT, FAILURE, CANNOT_TELL, INTERRUPTED = 1, 2, 3, 4, 130
