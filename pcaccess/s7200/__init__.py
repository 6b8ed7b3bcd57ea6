"""What an S7-200 is: pure data and functions, no I/O."""
