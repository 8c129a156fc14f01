"""The page that ``musclewire reproduce`` writes: rows, figures and where each number comes from."""
