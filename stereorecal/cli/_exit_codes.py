"""The exit codes of every command."""

BAD_INPUT, FAILURE, INTERRUPTED = 2, 3, 130
