"""What goes into a call of the native core and comes out: motion (a body), scene (several), rigid (props)."""
