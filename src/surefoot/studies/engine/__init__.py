"""What all studies share: cells, tables on disk, workers, reports."""
