"""What goes into a call of the native core and comes out, and what makes a body.

motion and scene (what happens in a call, and what comes of it), backend (makes bodies and scenes), rigid (props),
glide and pushed (changing constants, and fingertips that a force pushes).
"""
