//! What is looked at and from where: camera, camera path, light, scene file.
