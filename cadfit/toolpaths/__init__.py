"""Tool paths: G-code read, its cutting moves refitted within a tolerance, the rest left as it is."""
