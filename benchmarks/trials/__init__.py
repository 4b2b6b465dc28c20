"""Random cracks in random volumes: drawn, meshed and checked by means of their own."""
