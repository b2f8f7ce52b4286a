"""Methods against each other and against the theoretical limit."""
