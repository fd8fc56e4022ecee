"""What is pressed: cubes, Blender's primitives, everyday shapes, meshes from files."""
