"""Parts of the gradation: working arrays, passes, preprocessing, cleaning and the report."""
