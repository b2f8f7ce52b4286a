"""A study from a file: which parameters take which values, what is measured."""
