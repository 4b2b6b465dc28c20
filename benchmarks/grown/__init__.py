"""Cracks that grow through whole campaigns, each against what is known of its path."""
