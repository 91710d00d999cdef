"""Reference load paths: depth paths that may turn, and loads and machines read off them."""
