//! Which words of a storage buffer a shader declares as floats.

use wgpu::naga;

/// The 32-bit words of a storage buffer that are floats.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct FloatWords {
    /// Whether each word before the repeated part is a float.
    head: Vec<bool>,
    /// Whether each word of an element is a float, in the array of any length with which the buffer ends; empty if it
    /// does not end with one.
    element: Vec<bool>,
}

impl FloatWords {
    /// Returns the floats of a type.
    pub(super) fn of(module: &naga::Module, ty: naga::Handle<naga::Type>) -> Self {
        let mut words = Self::default();
        words.add(module, ty, 0);
        words
    }

    /// Returns whether there are any.
    pub(crate) fn has_any(&self) -> bool {
        self.head.contains(&true) || self.element.contains(&true)
    }

    /// Returns whether a word of the buffer is a float.
    pub(crate) fn is_float(&self, word: usize) -> bool {
        match word.checked_sub(self.head.len()) {
            None => self.head[word],
            Some(_) if self.element.is_empty() => false,
            Some(after) => self.element[after % self.element.len()],
        }
    }

    fn set(&mut self, word: usize) {
        if self.head.len() <= word {
            self.head.resize(word + 1, false);
        }
        self.head[word] = true;
    }

    /// Adds a type that begins at a word.
    fn add(&mut self, module: &naga::Module, ty: naga::Handle<naga::Type>, at: usize) {
        let is_float = |scalar: &naga::Scalar| *scalar == naga::Scalar::F32;
        match &module.types[ty].inner {
            naga::TypeInner::Scalar(scalar) if is_float(scalar) => self.set(at),
            naga::TypeInner::Vector { size, scalar } if is_float(scalar) => {
                (0..*size as usize).for_each(|i| self.set(at + i));
            }
            naga::TypeInner::Matrix { columns, rows, scalar } if is_float(scalar) => {
                // Columns of three rows are as far apart as those of four.
                let stride = if *rows == naga::VectorSize::Bi { 2 } else { 4 };
                for column in 0..*columns as usize {
                    (0..*rows as usize).for_each(|row| self.set(at + column * stride + row));
                }
            }
            naga::TypeInner::Struct { members, .. } => {
                members.iter().for_each(|member| self.add(module, member.ty, at + member.offset as usize / 4));
            }
            naga::TypeInner::Array { base, size, stride } => {
                let stride = *stride as usize / 4;
                match size {
                    naga::ArraySize::Constant(count) => {
                        (0..count.get() as usize).for_each(|i| self.add(module, *base, at + i * stride));
                    }
                    _ => {
                        let element = Self::of(module, *base);
                        self.head.resize(at, false);
                        self.element = element.head;
                        self.element.resize(stride, false);
                    }
                }
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floats_of(text: &str, words: usize) -> String {
        let module = naga::front::wgsl::parse_str(text).expect("the shader is valid");
        let (_, variable) = module.global_variables.iter().next().expect("it has a variable");
        let found = FloatWords::of(&module, variable.ty);
        (0..words).map(|word| if found.is_float(word) { 'f' } else { '.' }).collect()
    }

    #[test]
    fn floats_are_found_in_all_types() {
        let of = |structs: &str, ty: &str, words| {
            floats_of(&format!("{structs} @group(0) @binding(0) var<storage, read_write> list: {ty};"), words)
        };
        assert_eq!(of("", "array<f32>", 4), "ffff");
        assert_eq!(of("", "array<u32>", 4), "....");
        assert_eq!(of("", "array<vec3<f32>>", 8), "fff.fff.");
        assert_eq!(of("", "array<atomic<u32>, 2>", 2), "..");
        assert_eq!(of("", "array<f32, 2>", 4), "ff..");
        assert_eq!(of("", "mat3x3<f32>", 12), "fff.fff.fff.");
        let edge = "struct Edge { id: u32, at: vec2<f32>, far: f32 }";
        // `at` is aligned to two words, and so is the end of the struct.
        assert_eq!(of(edge, "array<Edge>", 12), "..fff...fff.");
        let list = "struct Edge { id: u32, far: f32 } struct List { count: u32, width: f32, edges: array<Edge> }";
        assert_eq!(of(list, "List", 8), ".f.f.f.f");
    }
}
