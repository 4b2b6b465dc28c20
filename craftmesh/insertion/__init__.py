"""The crack's way into a conformal surface."""
