"""What studies share: command line, tables, figures, units, timing, batches, random cases."""
